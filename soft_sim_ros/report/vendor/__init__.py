"""Third-party files contained in reports, unchanged.

``three.module.min.js``: three.js r170, file ``build/three.module.min.js`` of the npm package
``three`` 0.170.0. MIT licence, its text is in ``LICENSE.three.txt``. sha256 of the file:
08fd7545d13d2c7fb65ab691530a802dafefd638596501854f267d0fb13c39e7.
"""
