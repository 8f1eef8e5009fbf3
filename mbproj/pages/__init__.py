"""Mechanisms that move in a browser: what they look like, the motion as compact data, and one page that holds all.

`look` says what is drawn, for pages and pictures alike; `data` packs what moves; `page` writes the file; `browser` is
the page's own script and style, data of the package.
"""
