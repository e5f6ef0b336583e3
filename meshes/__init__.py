"""The crawler shoe: its dimensions, its mesher and the ready meshes."""

import lazy_loader

# dimensions alone load fast
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
