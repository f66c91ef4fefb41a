"""The commands, one module each: ``add_arguments(parser)`` and ``run(arguments, progress) -> exit status``.

Nothing heavy is imported at the top of these modules: ``synth fit --help`` answers at once.
"""
