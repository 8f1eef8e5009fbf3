"""What runs many simulations: comparisons, trade-offs, recommendations, certificates, batches, the paper's examples."""
