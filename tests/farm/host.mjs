// SPDX-License-Identifier: GPL-3.0-or-later
// Compiles a Flamenco 3 job type as Flamenco Manager does, and checks what a Manager or Worker would refuse.
//
// Reads {"script", "settings", "variables"} from stdin, where script is the path of the job type. Prints the JOB_TYPE;
// if there are settings, also the tasks, each with the command lines that a Worker would run. Exits with 1 and a
// sentence if something is wrong.
//
// Faithful to Flamenco 3.x in: the global names; strict mode; `addTask` and `addCommand`, which copy what they are given,
// so that later changes are lost; the commands and their parameters; how `blender-render` builds its command line.
// Only POSIX paths are understood here.

import { readFileSync } from "node:fs";
import { posix } from "node:path";
import vm from "node:vm";

const SETTING_KEYS = ["key", "type", "subtype", "choices", "propargs", "description", "label", "default", "eval", "evalInfo",
    "visible", "required", "editable"];
const SETTING_TYPES = { string: "string", int32: "number", float: "number", bool: "boolean" };
const SUBTYPES = ["file_path", "file_name", "dir_path", "hashed_file_path"];
const VISIBILITIES = ["visible", "hidden", "submission", "web"];

const text = (value) => typeof value === "string" && value !== "";
const anyText = (value) => typeof value === "string";
const list = (value) => Array.isArray(value) && value.every((each) => ["string", "number"].includes(typeof each));
const number = (value) => typeof value === "number";

// Parameters of each command that Workers know: how they are checked, and whether they must be there.
const COMMANDS = {
    "echo": { message: [text, true] },
    "sleep": { duration_in_seconds: [number, true] },
    "exec": { exe: [text, true], args: [list, false] },
    "blender-render": {
        exe: [text, true], exeArgs: [anyText, false], argsBefore: [list, false], blendfile: [anyText, true], args: [list, false],
    },
    "frames-to-video": {
        exe: [text, true], exeArgs: [anyText, false], fps: [number, true], inputGlob: [text, true], outputFile: [text, true],
        argsBefore: [list, false], args: [list, false],
    },
    "move-directory": { src: [text, true], dest: [text, true] },
    "copy-file": { src: [text, true], dest: [text, true] },
};
const TASK_TYPES = ["blender", "ffmpeg", "file-management", "misc"];

function refuse(sentence) {
    throw new Error(sentence);
}

function check(condition, sentence) {
    condition || refuse(sentence);
}

// --- what scripts see -----------------------------------------------------------------------------------------------

class Task {
    constructor(name, type) {
        Object.assign(this, { name, type, commands: [], dependencies: [] });
    }

    addCommand(command) {
        this.commands.push({ ...command });
    }

    addDependency(task) {
        check(task instanceof Task, `task '${this.name}' depends on something that is no task`);
        this.dependencies.push(task);
    }
}

const author = {
    Task(name, type) {
        check(text(name?.trim()) && text(type?.trim()), "author.Task(name, type): both are required");
        return new Task(name.trim(), type.trim());
    },
    Command(name, parameters, totalStepCount = 0) {
        check(text(name) && typeof parameters === "object", "author.Command(name, parameters): both are required");
        return { name, parameters, totalStepCount };
    },
};

const path = {
    basename: (file) => posix.basename(file),
    dirname: (file) => posix.dirname(file),
    join: (...parts) => posix.join(...parts),
    stem: (file) => posix.parse(file).name,
};

function formatTimestampLocal(time) {
    const two = (value) => String(value).padStart(2, "0");
    const date = [time.getFullYear(), two(time.getMonth() + 1), two(time.getDate())].join("-");
    return `${date}_${two(time.getHours())}${two(time.getMinutes())}${two(time.getSeconds())}`;
}

// Words of a command line: blanks part them, quotes and backslashes keep them together.
function shellSplit(line) {
    const words = line.match(/(?:[^\s"'\\]|\\.|"(?:[^"\\]|\\.)*"|'[^']*')+/g) ?? [];
    return words.map((word) => word.replace(/\\(.)|"((?:[^"\\]|\\.)*)"|'([^']*)'/g, (_, escaped, double, single) =>
        escaped ?? double?.replace(/\\(["\\])/g, "$1") ?? single));
}

const quiet = (...said) => process.stderr.write(`${said.join(" ")}\n`);

function load(script) {
    const globals = { print: quiet, alert: quiet, formatTimestampLocal, shellSplit, author, path, process: { platform: process.platform } };
    const context = vm.createContext(globals, { codeGeneration: { strings: false, wasm: false } });
    vm.runInContext(`"use strict"; ${readFileSync(script, "utf8")}`, context, { filename: script });
    // Top-level constants are no properties of the global object, neither here nor in Flamenco's goja.
    const found = (name) => vm.runInContext(`typeof ${name} === "undefined" ? undefined : ${name}`, context);
    return { jobType: found("JOB_TYPE"), compileJob: found("compileJob") };
}

// --- what a Manager checks --------------------------------------------------------------------------------------------

function checkJobType(jobType) {
    check(jobType && text(jobType.label), "JOB_TYPE needs a label");
    check(Array.isArray(jobType.settings) || jobType.settings?.length >= 0, "JOB_TYPE needs settings");
    const keys = new Set();
    for (const setting of jobType.settings) {
        const { key, type } = setting;
        check(text(key) && /^[a-z][a-z0-9_]*$/.test(key), `setting '${key}' has no proper key`);
        check(!keys.has(key), `setting '${key}' is there twice`);
        keys.add(key);
        for (const name of Object.keys(setting)) {
            check(SETTING_KEYS.includes(name), `setting '${key}' has an unknown '${name}'`);
        }
        check(type in SETTING_TYPES, `setting '${key}' has no proper type`);
        check(setting.subtype === undefined || (type === "string" && SUBTYPES.includes(setting.subtype)), `subtype of '${key}'`);
        check(setting.visible === undefined || VISIBILITIES.includes(setting.visible), `visibility of '${key}'`);
        check(setting.choices === undefined || (type === "string" && list(setting.choices)), `choices of '${key}'`);
        check(setting.default === undefined || fits(setting, setting.default), `default of '${key}'`);
        check(setting.eval === undefined || text(setting.eval), `eval of '${key}'`);
    }
}

function fits(setting, value) {
    return typeof value === SETTING_TYPES[setting.type]
        && (setting.type !== "int32" || Number.isInteger(value))
        && (setting.choices === undefined || setting.choices.includes(value))
        && (setting.propargs?.min === undefined || value >= setting.propargs.min)
        && (setting.propargs?.max === undefined || value <= setting.propargs.max);
}

// The add-on sends a value for each setting: a default where there is one, and else what its property is without any.
function submitted(jobType, given) {
    const empty = { string: "", int32: 0, float: 0.0, bool: false };
    const settings = {};
    for (const setting of jobType.settings) {
        settings[setting.key] = given[setting.key] ?? setting.default ?? empty[setting.type];
        check(!setting.required || given[setting.key] !== undefined || setting.default !== undefined, `setting '${setting.key}' is required`);
        check(given[setting.key] === undefined || fits(setting, given[setting.key]), `setting '${setting.key}' does not fit`);
    }
    for (const key of Object.keys(given)) {
        check(key in settings, `there is no setting '${key}'`);
    }
    return settings;
}

// --- what Workers check -----------------------------------------------------------------------------------------------

function checkTasks(tasks, originals) {
    check(tasks.length > 0, "the job has no tasks");
    for (const task of tasks) {
        check(TASK_TYPES.includes(task.type), `task '${task.name}' is of the unknown type '${task.type}'`);
        check(task.commands.length > 0, `task '${task.name}' has no commands`);
        task.commands.forEach(checkCommand);
        for (const dependency of task.dependencies) {
            check(originals.includes(dependency), `task '${task.name}' depends on '${dependency.name}', which is not in the job`);
        }
    }
    const state = new Map();
    const visit = (task) => {
        check(state.get(task) !== "open", `task '${task.name}' waits for itself`);
        if (!state.has(task)) {
            state.set(task, "open");
            task.dependencies.forEach(visit);
            state.set(task, "done");
        }
    };
    originals.forEach(visit);
}

function checkCommand({ name, parameters }) {
    const known = COMMANDS[name] ?? refuse(`Workers know no command '${name}'`);
    for (const key of Object.keys(parameters)) {
        check(key in known, `command '${name}' has no parameter '${key}'`);
    }
    for (const [key, [proper, required]] of Object.entries(known)) {
        check(key in parameters ? proper(parameters[key]) : !required, `parameter '${key}' of command '${name}'`);
    }
}

function commandLine({ name, parameters }, variables) {
    const expand = (value) => String(value).replace(/{(\w+)}/g, (whole, key) => variables[key] ?? whole);
    const all = (values) => (values ?? []).map(expand);
    if (name === "exec") {
        return [expand(parameters.exe), ...all(parameters.args)];
    }
    if (name !== "blender-render") {
        return null; // done by the Worker itself
    }
    const before = [...shellSplit(expand(parameters.exeArgs ?? "")), ...all(parameters.argsBefore)];
    const blendfile = parameters.blendfile ? [expand(parameters.blendfile)] : [];
    return [expand(parameters.exe), ...before, ...blendfile, ...all(parameters.args)];
}

function compile(compileJob, settings, variables) {
    check(typeof compileJob === "function", "the script has no function compileJob(job)");
    const originals = [], tasks = [];
    const job = {
        jobID: "00000000-0000-4000-8000-000000000000", name: "job", jobType: "prt-bake", priority: 50, status: "under-construction",
        created: new Date(2026, 0, 2, 3, 4, 5), settings, metadata: {},
        addTask(task) {
            check(task instanceof Task, "job.addTask(task): that is no task");
            originals.push(task);
            tasks.push({ ...task, commands: [...task.commands], dependencies: [...task.dependencies] });
        },
    };
    compileJob(job);
    checkTasks(tasks, originals);
    return tasks.map((task) => ({
        name: task.name,
        type: task.type,
        dependencies: task.dependencies.map((dependency) => originals.indexOf(dependency)),
        commands: task.commands.map((command) => ({ ...command, line: commandLine(command, variables) })),
    }));
}

try {
    const { script, settings, variables } = JSON.parse(readFileSync(0, "utf8"));
    const { jobType, compileJob } = load(script);
    checkJobType(jobType);
    const answer = { jobType };
    if (settings) {
        answer.settings = submitted(jobType, settings);
        answer.tasks = compile(compileJob, answer.settings, variables ?? {});
    }
    console.log(JSON.stringify(answer));
} catch (error) {
    console.error(`${error?.message ?? error}`);
    process.exit(1);
}
