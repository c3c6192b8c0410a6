#include "cli/farm_script.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "base/shell_words.hpp"
#include "base/version.hpp"

namespace regulus::cli {

namespace {

// No text of the scene's or the user's stands in a comment, where a line break would end it.
constexpr const char* HEAD = R"sh(#!/bin/sh
# Renders {count} {what} in {parts} parts. Written by regulus {version} farm.
#
#   sh THIS            {begins}
#   sh THIS task K     renders part K, from 0 on, from its checkpoint if there is one
{merge_line}#
# What is done is not done again: after a failure of any kind run it again.
set -u
script=$(unset CDPATH && cd -- "$(dirname -- "$0")" && pwd -P)/$(basename -- "$0")
cd {folder} || exit 1
regulus={program}
[ -z "${{REGULUS:-}}" ] || regulus=$REGULUS # where it lies elsewhere
output={output}
work={work}
parts={parts} first={first} count={count}

render() {{ "$regulus" render{options} "$@"; }}

# The first {unit} of part K; that of part K + 1 is the one after its last.
start_of() {{ echo $((first + count * $1 / parts)); }}

# The files of part K, without their extensions.
name_of() {{ printf '%s/{what}-%07d-%07d' "$work" "$(start_of "$1")" "$(($(start_of $(($1 + 1))) - 1))"; }}

)sh";

constexpr const char* SAMPLE_TASK = R"sh(task() {
  mkdir -p -- "$work" || return
  name=$(name_of "$1") start=$(start_of "$1") end=$(start_of $(($1 + 1)))
  [ ! -e "$name.exr" ] || return 0
  render --samples="$start:$((end - start))" --checkpoint="$name.state.exr" --resume \
    --output="$name.unfinished.exr" || return
  mv -f -- "$name.unfinished.exr" "$name.exr" && rm -f -- "$name.state.exr"
}

merge() {
  set --
  part=0
  while [ "$part" -lt "$parts" ]; do
    set -- "$@" "$(name_of "$part").exr"
    part=$((part + 1))
  done
  rm -f -- "$work/merged.exr"
  "$regulus" merge "$work/merged.exr" "$@" && mv -f -- "$work/merged.exr" "$output"
}

)sh";

constexpr const char* FRAME_TASK = R"sh(task() {
  mkdir -p -- "$work" || return
  name=$(name_of "$1") start=$(start_of "$1") end=$(start_of $(($1 + 1)))
  [ ! -e "$name.done" ] || return 0
  render --frames="$start:$((end - 1))" --checkpoint="$name.state.exr" --resume --output="$output" || return
  : >"$name.done" && rm -f -- "$name".state.*.exr
}

)sh";

// A command line or a scene that is wrong (2, 3) stays so, and who interrupts (130) means it.
constexpr const char* SHELL = R"sh(try_task() {
  for attempt in 1 2 3; do
    task "$1" && return
    status=$?
    case $status in 2 | 3 | 130) return "$status" ;; esac
    echo "part $1 failed with status $status (attempt $attempt)" >&2
  done
  return "$status"
}

everything() {
  part=0
  while [ "$part" -lt "$parts" ]; do
    try_task "$part" || return
    part=$((part + 1))
  done@MERGE@
}
)sh";

constexpr const char* PARALLEL =
    R"sh(# JOBS tasks at a time on each machine (1: a render takes all of one); other options, such as the machines, in PARALLEL.
everything() {
  farm_script=$script
  export farm_script
  seq 0 $((parts - 1)) |
    parallel --will-cite --env farm_script --jobs "${JOBS:-1}" --retries 3 'sh "$farm_script" task {}' || return@MERGE@
}
)sh";

// Slurm reads a % in --output as the beginning of a number's name.
constexpr const char* SLURM =
    R"sh(# Partition, time limit and the like come from sbatch's own variables: SBATCH_PARTITION, SBATCH_TIMELIMIT.
everything() {
  mkdir -p -- "$work" || return
  log=$(cd -- "$work" && pwd -P | sed 's/%/%%/g') || return
  tasks=$(sbatch --parsable --job-name=regulus --requeue --open-mode=append --array="0-$((parts - 1))" \
    --output="$log/task-%a.log" "$script" array-task) || return
  tasks=${tasks%%;*}
  echo "tasks: job $tasks"@MERGE@
}

# A task that is killed is put into the queue again, three times at most.
array_task() {
  task "$SLURM_ARRAY_TASK_ID" && return
  status=$?
  case $status in 2 | 3 | 130) return "$status" ;; esac
  [ "${SLURM_RESTART_COUNT:-0}" -ge 3 ] || scontrol requeue "$SLURM_JOB_ID"
  return "$status"
}
)sh";

constexpr const char* SLURM_MERGE = R"sh(
  merge=$(sbatch --parsable --job-name=regulus-merge --requeue --open-mode=append --dependency="afterok:$tasks" \
    --kill-on-invalid-dep=yes --output="$log/merge.log" "$script" merge) || return
  echo "merge: job ${merge%%;*}")sh";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

}  // namespace

std::string parts_folder(const std::string& output) {
  return std::filesystem::path(output).replace_extension(".parts").string();
}

std::string farm_script(const FarmJob& job) {
  const bool is_slurm = job.scheduler == "slurm";
  std::string options;
  for (const std::string& option : job.options) options += " " + shell_word(option);
  options += " " + shell_word(not_an_option(job.scene));
  std::string script =
      fmt::format(HEAD, fmt::arg("count", job.count), fmt::arg("what", job.has_frames ? "frames" : "samples"),
                  fmt::arg("unit", job.has_frames ? "frame" : "sample"), fmt::arg("parts", job.parts),
                  fmt::arg("first", job.first), fmt::arg("version", VERSION),
                  fmt::arg("begins", is_slurm ? "gives all of it to Slurm and returns" : "does all of it"),
                  fmt::arg("merge_line", job.has_frames ? "" : "#   sh THIS merge      joins the parts\n"),
                  fmt::arg("folder", shell_word(job.folder)), fmt::arg("program", shell_word(job.program)),
                  fmt::arg("options", options), fmt::arg("output", shell_word(not_an_option(job.output))),
                  fmt::arg("work", shell_word(not_an_option(parts_folder(job.output)))));
  script += job.has_frames ? FRAME_TASK : SAMPLE_TASK;
  script += replaced(is_slurm                      ? SLURM
                     : job.scheduler == "parallel" ? PARALLEL
                                                   : SHELL,
                     "@MERGE@",
                     job.has_frames ? ""
                     : is_slurm     ? SLURM_MERGE
                                    : "\n  merge");
  script += "\ncase ${1:-} in\n  '') everything ;;\n  task) task \"$2\" ;;\n";
  if (!job.has_frames) script += "  merge) merge ;;\n";
  if (is_slurm) script += "  array-task) array_task ;;\n";
  return script + "  *) sed -n '2,/^set/s/^# \\{0,1\\}//p' \"$0\" >&2; exit 2 ;;\nesac\n";
}

}  // namespace regulus::cli
