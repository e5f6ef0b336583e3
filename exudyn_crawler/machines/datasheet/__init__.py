"""Datasheets: a machine from its maker's figures; rules or typical values give every other value.

`sheet` has the keys of a datasheet, `typical` the table of typical values with range and source. `rules` has
small functions with their sources, `derive` the derived case, and `library` machines as files.
"""
