"""What accuracy costs on a mechanism, measured over a designed grid."""
