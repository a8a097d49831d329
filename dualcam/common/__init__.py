"""What all other rooms share: arrays and numbers that a user hands in, paths, units that look wrong,
archives, the one reader of tables that people wrote, parts of HTML pages.

May import no other room.
"""
