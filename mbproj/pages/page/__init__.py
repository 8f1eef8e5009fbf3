"""The page: one HTML file with three.js, our scripts and style, and the data. It opens from a disk, without a
network."""
