"""A local page for people who do not live in a terminal: ``camid studio``.

``project`` holds what was chosen so far, ``job`` runs the commands of camid in processes, ``guard`` keeps others out;
they know nothing of the framework that draws the page (``page``, ``*_step``), which is loaded by ``server`` alone.
"""
