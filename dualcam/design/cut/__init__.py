"""Cut a groove: path of the pin, flanks, and files for a workshop. The public names are those of
dualcam.design."""
