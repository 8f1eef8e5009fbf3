"""Results as others show them: in a prompt, in a notebook, as tables of other libraries."""
