"""Pages on which mechanisms move in a browser: one HTML file with three.js, our scripts, and the data."""
