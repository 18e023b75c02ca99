"""Judges the diagnosis on recordings of physics in forms that no catalogue has, and on nulls."""
