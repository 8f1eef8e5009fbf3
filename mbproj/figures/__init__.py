"""Pictures of results: the only package that imports matplotlib. `kinds.draw` draws what `mbproj plot` shows, `pages`
draws what studies show, `save` writes both."""

from mbproj.registry import lazily

__getattr__ = lazily(
    __name__,
    {
        "kinds": "KINDS draw why_not",
        "kinds.film": "duration_and_speed times_of",
        "kinds.mechanism": "draw_start",
        "kinds.poses": "picture_axes projected",
        "pages.modes": "PICTURES",
        "pages.profile": "draw_profile",
        "pages.sensitivity": "draw_sensitivities",
        "style": "REFUSED STYLE read_sheet",
    },
)
