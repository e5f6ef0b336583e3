"""A case's tables as Exudyn's own items, their rest, and the choice of the formulation."""
