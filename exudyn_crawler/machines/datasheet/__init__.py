"""Datasheets: a machine from what its maker prints, every other value by a stated rule or a typical one.

`sheet` has what a datasheet may say, `typical` the table of typical values with range and source, `rules`
small functions with theirs, `derive` the case that follows, and `library` machines as files.
"""
