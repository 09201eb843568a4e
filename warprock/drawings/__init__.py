"""Drawings of assemblies: files of polygons, a block each."""
