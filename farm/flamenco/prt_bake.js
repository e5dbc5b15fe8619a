// SPDX-License-Identifier: GPL-3.0-or-later
// A Flamenco 3 job type: bakes PRT Relight's transport in shards on many workers, and merges them into a new .blend.
// See docs/farm.md.

const JOB_TYPE = {
    label: "PRT Bake",
    description: "Bake precomputed radiance transfer in shards, then merge them into a new .blend",
    settings: [
        { key: "shards", type: "int32", required: true, default: 8, propargs: { min: 1, max: 10000 }, visible: "submission",
          description: "How many tasks share the rays; each also reads the whole scene" },
        { key: "mode", label: "Transport", type: "string", required: true, choices: ["SHADOWED", "INTERREFLECTED"],
          default: "INTERREFLECTED",
          eval: "C.scene.prt.mode if C.scene.prt.mode != 'UNSHADOWED' else 'SHADOWED'",
          evalInfo: { showLinkButton: true, description: "The scene's setting" },
          description: "Which light paths are baked" },
        { key: "samples", type: "int32", required: true, default: 256, propargs: { min: 1 },
          eval: "C.scene.prt.samples", evalInfo: { showLinkButton: true, description: "The scene's setting" },
          description: "Rays per vertex" },
        { key: "bounces", type: "int32", required: true, default: 3, propargs: { min: 1, max: 100 },
          eval: "C.scene.prt.bounces", evalInfo: { showLinkButton: true, description: "The scene's setting" },
          description: "How often light bounces between surfaces" },
        { key: "tolerance", type: "float", default: 0.0, propargs: { min: 0.0 },
          eval: "C.scene.prt.tolerance", evalInfo: { showLinkButton: true, description: "The scene's setting" },
          description: "If above zero: bounce until no coefficient changes by as much" },
        { key: "seed", type: "int32", default: 0, propargs: { min: 0 },
          eval: "C.scene.prt.seed", evalInfo: { showLinkButton: true, description: "The scene's setting" },
          description: "Another seed gives another pattern of noise" },
        { key: "shard_root", type: "string", subtype: "dir_path", required: true, visible: "submission",
          eval: "bpy.path.abspath('//prt_shards')",
          description: "Folder that all workers see; the shards of each job go into a folder of their own in there" },
        { key: "output_blend", type: "string", subtype: "file_path", required: true,
          eval: "str(Path(bpy.data.filepath).with_suffix('')) + '_prt.blend'",
          description: "The .blend that gets the result; the submitted one stays as it is" },

        // Filled in without being asked for:
        { key: "blendfile", type: "string", required: true, visible: "web", description: "The .blend to bake" },
        { key: "shard_directory", type: "string", visible: "web", description: "Where the shards of this job are" },
    ],
};

const MODES = ["SHADOWED", "INTERREFLECTED"];

function compileJob(job) {
    const settings = job.settings;
    checkSettings(settings);
    const folder = `${path.stem(settings.blendfile)}-${formatTimestampLocal(job.created)}`;
    settings.shard_directory = path.join(settings.shard_root, folder);

    const merge = mergeTask(settings);
    for (let index = 0; index < settings.shards; index++) {
        const shard = shardTask(settings, index);
        merge.addDependency(shard);
        job.addTask(shard);
    }
    job.addTask(merge);
    print(`PRT Bake: ${settings.shards} shards of ${settings.blendfile}`);
}

function checkSettings(settings) {
    if (!(settings.shards >= 1)) {
        throw "PRT Bake: 'shards' must be 1 or more";
    }
    if (MODES.indexOf(settings.mode) < 0) {
        throw `PRT Bake: 'mode' must be one of ${MODES.join(", ")}`;
    }
    for (const key of ["blendfile", "shard_root", "output_blend"]) {
        if (!settings[key]) {
            throw `PRT Bake: '${key}' is missing`;
        }
    }
    if (settings.output_blend === settings.blendfile) {
        throw "PRT Bake: 'output_blend' must be another file than the one that is baked";
    }
}

function shardTask(settings, index) {
    const bake = `bpy.ops.prt.bake_shard(directory=folder, index=${index}, count=${settings.shards}, ${bakeArguments(settings)})`;
    const task = author.Task(`shard-${index}-of-${settings.shards}`, "blender");
    task.addCommand(runPython(settings, ["folder"], [settings.shard_directory], [bake]));
    return task;
}

// The result is saved under another name and then renamed: workers may be killed, and their tasks done again.
function mergeTask(settings) {
    const task = author.Task("merge", "blender");
    task.addCommand(runPython(settings, ["folder", "output"], [settings.shard_directory, settings.output_blend], [
        "import os",
        `bpy.ops.prt.merge_shards(directory=folder, ${bakeArguments(settings)})`,
        "bpy.ops.wm.save_as_mainfile(filepath=output + '.part.blend', copy=True)",
        "os.replace(output + '.part.blend', output)",
    ]));
    return task;
}

function bakeArguments(settings) {
    const numbers = [
        ["samples", settings.samples],
        ["bounces", settings.bounces],
        ["tolerance", settings.tolerance || 0.0],
        ["seed", settings.seed || 0],
    ];
    return [`mode='${settings.mode}'`, ...numbers.map(([name, value]) => `${name}=${Number(value)}`)].join(", ");
}

// Blender with the job's file and some Python. Paths travel behind `--`, beyond the reach of any quoting: workers of
// other systems spell them with backslashes. `--python-exit-code` only holds for what comes after it.
function runPython(settings, names, paths, lines) {
    const script = ["import bpy, sys", `${names.join(", ")}, = sys.argv[sys.argv.index('--') + 1:]`, ...lines];
    return author.Command("blender-render", {
        exe: "{blender}",
        exeArgs: "{blenderArgs}",
        argsBefore: [],
        blendfile: settings.blendfile,
        args: ["--python-exit-code", "1", "--python-expr", script.join("; "), "--", ...paths],
    });
}
