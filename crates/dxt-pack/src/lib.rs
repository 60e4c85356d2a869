//! Operator to block-compressed textures and outliers
