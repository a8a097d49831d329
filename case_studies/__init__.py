"""Long reports on the systems of dualcam.systems, and the paper by script. Each is run as a module from here:
python -m case_studies.paper, .robot_joint, .prosthetic_knee, .car_door."""
