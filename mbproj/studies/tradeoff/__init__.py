"""The trade-off between accuracy and cost on a mechanism, measured over a designed grid of settings."""
