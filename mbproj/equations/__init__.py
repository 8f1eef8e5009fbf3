"""The paper's equations at a pose, in NumPy, many poses at once; assembly; rank; derivatives."""
