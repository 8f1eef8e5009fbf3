"""What pictures of a design show, kept in its folder."""
