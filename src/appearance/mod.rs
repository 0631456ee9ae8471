//! What is seen: bidirectional distribution functions, the paper below, colour and pictures.
