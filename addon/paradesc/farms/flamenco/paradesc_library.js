// Flamenco job type: every asset of a folder into results and rows of their own, then one list of all. Existing results
// are kept, so tasks may be repeated. Plain ECMAScript 5.

var JOB_TYPE = {
    label: "Paradesc: Library",
    description: "Compute geometric descriptors of all mesh files of a folder",
    settings: [
        {key: "library", type: "string", subtype: "dir_path", required: true, description: "The folder of the assets"},
        {key: "output", type: "string", subtype: "dir_path", required: true,
         description: "The folder of the results and of library.jsonl, seen by all workers"},
        {key: "parts", type: "int32", default: 16, visible: "submission", description: "So many tasks share the assets"},
        {key: "descriptors", type: "string", default: "",
         description: "Names between commas; if empty, those of the options, else mean_curvature"},
        {key: "radius", type: "string", default: "",
         description: "A share of the bounding box's diagonal, or several between commas; if empty, 0.02"},
        {key: "backend", type: "string", choices: ["cpu", "gpu", "software"], default: "cpu",
         description: "What computes, on all workers alike"},
        {key: "options", type: "string", default: "", description: "More options of paradesc library, such as --samples 64"},
        {key: "program", type: "string", default: "paradesc", visible: "web",
         description: "What the commands begin with, between spaces"}
    ]
};

function compileJob(job) {
    var settings = job.settings;
    var listing = author.Task("listing", "misc");
    listing.addCommand(library(settings, []));
    for (var part = 1; part <= settings.parts; part++) {
        var task = author.Task("part-" + part, "misc");
        task.addCommand(library(settings, ["--part", part + "/" + settings.parts, "--allow-failures"]));
        listing.addDependency(task);
        job.addTask(task);
    }
    job.addTask(listing);
}

// The command that computes a part of the library, or lists all of it.
function library(settings, more) {
    var words = settings.program.split(" ").filter(function (word) { return word.length > 0; });
    return author.Command("exec", {
        exe: words[0],
        args: words.slice(1).concat([
            "library", settings.library, "--output", settings.output,
            "--descriptors", settings.descriptors || "", "--radius", settings.radius || "", "--backend", settings.backend || "cpu",
            "--also", settings.options || "", "--progress", "lines"
        ], more)
    });
}
