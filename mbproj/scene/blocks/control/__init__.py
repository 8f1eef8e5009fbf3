"""What a scene computes: signals, states, controllers; and what expressions may name."""
