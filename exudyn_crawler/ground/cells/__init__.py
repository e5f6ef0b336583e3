"""Ground of cells with memory under rectangular undersides: soil that compacts and rock, on a map of heights.

Calls by the equations, for shoes with frames (r, R, v, omega) in rows of `layouts.FRAME` numbers::

    ground = CellGround(law, heights, cell, corners, shoes)  # once; its `shoes` go into the tables
    ground.cover(predicted, accepted)  # once a step, before Newton's method
    press(shoes, frames, weights)  # compiled, as often as Newton's method asks
    ground.commit()  # once, after the step is accepted

`cover` freezes the cells under each shoe at the predicted frames of the step's end, and takes slip from the
frames of the last accepted step. `press` writes ``shoes.wrench`` (6, about the frame's origin)
and, with weights that are not both zero, ``shoes.tangent`` (6, 6), the derivative of the wrench by
displacements times ``weights[0]`` plus that by velocities times ``weights[1]``, in global components; small
rotations stand for rates of angles times their axes. It reads and writes ``shoes`` alone; the arrays of
``shoes`` stay the same through a run. `commit` takes the trial memory of the last `press`, which has to be at
the accepted state. A step that fails or is halved needs only another `cover`. For a residual at any other
state (a start, stored results) `cover` with both frames alike, `press`, and no `commit`.

`state` and `restore` keep the map bit for bit. `coarse_forces` gives the forces of the last `press` on a grid
of each underside.
"""
