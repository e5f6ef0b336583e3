"""A case as tables of bodies, markers, joints and force elements, and its equations of motion."""
