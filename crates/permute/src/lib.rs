//! One order for the rows and columns of the operator
