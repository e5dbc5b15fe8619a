# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the engine in a process of its own.

Blender allows no thread that outlives a call, and a crash of the ray caster must not take an unsaved file with it. So
`core` runs in a child of Blender's own Python:

    job      one piece of work: started, watched, cancelled, its result taken        in Blender
    engine   the child: started, talked to, ended                                    in Blender
    channel  messages over the connection of the two                                 in both
    tasks    what the child can do                                                   named in Blender, run in the child
    child    the program that Blender's Python runs                                  in the child
    serve    reads a job, carries it out, answers                                    in the child

Nothing here imports bpy.
"""
