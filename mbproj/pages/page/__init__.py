"""The page: one HTML file with three.js, our script and style, and the data; it opens from a disk without a network."""
