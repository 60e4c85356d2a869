//! Scene to patches: triangles clipped to voxels and grouped
