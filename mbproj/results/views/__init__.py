"""Views of results: in a prompt, in a notebook, as tables of other libraries."""
