//! The run time on a GPU: shadow maps, patch light, packed product, transfer, shading
