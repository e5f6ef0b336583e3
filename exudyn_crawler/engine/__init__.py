"""Exudyn's own items for a case's tables, their rest, and the choice of the formulation."""
