"""Fields: small definitions, each of which reads one kind of value and gives its schema."""
