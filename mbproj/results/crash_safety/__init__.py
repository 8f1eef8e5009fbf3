"""What keeps results whole when a run is killed, the disk fills up or two runs choose one file: only `writer` and
`files` use it."""
