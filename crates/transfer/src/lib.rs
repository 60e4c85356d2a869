//! Patch light to vertices and points: normalised, visibility-aware weights
