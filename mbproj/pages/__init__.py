"""Pages on which mechanisms move in a browser: their appearance, their motion as compact data, and the HTML file.

`appearance` decides what is drawn, for pages and pictures alike. `data` packs the motion; `page` writes the file.
`browser` has the page's own scripts and style, as data of the package.
"""

from mbproj.registry import lazily

__getattr__ = lazily(
    __name__,
    {
        "appearance.mechanism": "look_of",
        "appearance.motion": "PoseHistory motion_at",
    },
)
