//! Form factors to the all-bounce operator
