"""Functions of channels as flat programs with exact derivatives; elements, which are made of them; curves."""
