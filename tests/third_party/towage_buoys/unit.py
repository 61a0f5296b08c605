"""Unit `buoy`: the motion of the shipped ship under another name."""

from dataclasses import replace

from towage.fmus.ship import UNIT as SHIP
from towage_buoys.words import DESCRIPTION

from . import words

assert words.DESCRIPTION is DESCRIPTION  # both ways to import lead to one copy

BUOY = replace(SHIP, name="buoy", description=DESCRIPTION)
