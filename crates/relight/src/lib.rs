//! The run time on a CPU: direct light, packed product, transfer, pictures
