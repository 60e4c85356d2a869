//! Patches to form factors by a Sobol cosine gather
