"""What runs many simulations: a study is the cases, the runs, what is measured, a table."""
