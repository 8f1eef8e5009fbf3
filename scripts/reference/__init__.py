"""Tables of the guide's reference, from the definitions that the code itself runs on."""
