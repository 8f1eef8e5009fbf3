"""What acts through channels: elements are data, one file a kind."""
