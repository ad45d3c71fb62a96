"""The six strain components of a Cosserat rod, in the order used everywhere.

Twist K_x, bending K_y and K_z in 1/m (rotation per arc length about the section's x, y, z axis);
stretch Γ_x, shear Γ_y and Γ_z without unit (displacement of the centre line per arc length).
"""

STRAINS = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")
