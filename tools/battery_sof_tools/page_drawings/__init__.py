"""Drawings of the pages: diagrams as plain SVG, plots by matplotlib."""
