"""View factors between patches, with occlusion: matrices, their files, and how they are computed in blocks."""
