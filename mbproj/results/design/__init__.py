"""The data of a design's pictures, stored in the design's folder."""
