"""What runs many simulations: the paper's numerical examples."""
