"""Reduced elastic bodies from finite-element meshes, with recoverable stresses."""

import lazy_loader

# a mesh alone needs neither solver nor compiler
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
