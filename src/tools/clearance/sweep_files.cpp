#include "tools/clearance/sweep_files.h"

#include <array>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <optional>
#include <stdexcept>

#include "system/whole_file.h"
#include "tools/clearance/state_sweep.h"
#include "tools/command_line/content_hash.h"
#include "tools/sweep/model_digest.h"
#include "tools/sweep/program_digest.h"
#include "tools/sweep/row_file.h"
#include "tools/sweep/sweep_folder.h"
#include "tools/sweep/sweep_manifest.h"

namespace proximity_server::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kProgram = "proximity_server " PROXIMITY_VERSION;

double coreSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::string threeDigits(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", number);
  return text.data();
}

Json describeModel(const scene::SceneModel& model) {
  const ModelDigest digest = digestOf(model);
  return {{"robot", model.robot.name}, {"joints", digest.joints}, {"shapes", digest.shapes}, {"pairs", digest.pairs}};
}

Json namesOf(const ClearanceQuestion& question) {
  Json names = Json::array();
  const scene::RobotModel& robot = question.model->robot;
  for (const scene::ShapeRefPair& pair : question.pairs)
    names.push_back({nameOf(pair.a, robot), nameOf(pair.b, robot)});
  return names;
}

StateRows rowsOf(const Sweep& sweep) { return {sweep.state_question.selection, sweep.format, sweep.question}; }

/// Computes a range into a file. Returns its manifest, whose `sweep` is empty.
SweepManifest compute(const Sweep& sweep, StateSource& states, const StateRange& range, AnswerCounter& counter,
                      RowFile& file) {
  const StateRows rows = rowsOf(sweep);
  const auto write = [&](const WrittenRows& written) {
    file.beginRows(written.rows);
    file.append(written.bytes);
  };
  SweepManifest manifest;
  manifest.summary = sweepStates(sweep.question, sweep.state_question, states, range,
                                 {rows, write, [&](std::uint64_t count) { counter.count(count); }});
  counter.clear();
  manifest.range = {range.begin, range.begin + manifest.summary.states};
  file.complete(manifest);
  return manifest;
}

/// The format of the files of a sweep. Throws std::invalid_argument if this program does not know it.
OutputFormat formatOf(const Json& sweep) {
  const std::string name = sweep.at("output").at("format");
  const Json& question = sweep.at("question");
  const PairSelection selection = readPairSelection(question.at("pairs"));
  const LevelColumn levels = question.value("thresholds", Json()).is_null() ? LevelColumn::Without : LevelColumn::With;
  for (const RowFormat format : {RowFormat::Csv, RowFormat::Json, RowFormat::Npy}) {
    OutputFormat known = StateRows::format(selection, format, sweep.at("pairs").size(), levels);
    if (known.name == name) return known;
  }
  throw std::invalid_argument("format \"" + name + "\": unknown");
}

}  // namespace

Json describe(const Sweep& sweep, const StateSource& states, std::uint64_t count) {
  const OutputFormat format = rowsOf(sweep).format();
  const ObjectSchedule* const objects = sweep.question.objects.get();
  Json json;
  json["program"] = {{"version", kProgram}, {"digest", programDigest()}};
  json["model"] = describeModel(*sweep.question.model);
  json["question"] = {
      {"pairs", textOf(sweep.state_question.selection)},
      {"filter", sweep.question.filter == PairFilter::On},
      {"skipping", sweep.state_question.skipping == scene::Skipping::On},
      {"objects", sweep.objects.empty() ? Json() : Json(contentHash(sweep.objects))},
      // The meshes of objects lie in files of their own.
      {"object_shapes", objects ? Json(shapesDigestOf(objects->all())) : Json()},
      {"thresholds", sweep.thresholds.empty() ? Json() : Json(contentHash(sweep.thresholds))},
      // The joints of groups stand in the SRDF.
      {"thresholds_of_pairs",
       sweep.question.thresholds ? Json(digestOf(*sweep.question.thresholds, sweep.question.model->robot)) : Json()}};
  json["states"] = {{"identity", states.identity()}, {"count", count}};
  json["output"] = {{"format", format.name}, {"type", format.npy_type}};
  json["pairs"] = namesOf(sweep.question);
  return json;
}

void computePart(const Sweep& sweep, const SweepOptions& options, StateSource& states, const std::string& folder) {
  const std::optional<std::uint64_t> count = states.count();
  const StateRange range = rangeOf(options, count, states.source());
  const Json described = describe(sweep, states, *count);
  const OutputFormat format = rowsOf(sweep).format();
  const SweepFolder parts(folder);
  const std::string path = parts.file(range, format);
  if (parts.isDone(described, range, format)) {
    std::cerr << "clearance: " << path << " is there already\n";
    return;
  }
  const CoreTime time;
  AnswerCounter counter("states", range.size());
  RowFile file(path, format);
  SweepManifest manifest = compute(sweep, states, range, counter, file);
  manifest.sweep = described;
  writeManifest(manifest, path);
  std::cerr << "clearance: " << path << ": " << manifest.summary.text() << "\n  "
            << time.text(range.size(), manifest.bytes) << '\n';
}

SweepSummary computeNpy(const Sweep& sweep, StateSource& states, const std::string& out, AnswerCounter& counter,
                        std::uint64_t& bytes) {
  system::removeLeftOvers(out);
  Json described = describe(sweep, states, 0);  // before the run, which may outlast the files that it was made of
  RowFile file(out, rowsOf(sweep).format());
  SweepManifest manifest = compute(sweep, states, {0, kToTheEnd}, counter, file);
  described["states"]["count"] = manifest.range.end;
  manifest.sweep = described;
  writeManifest(manifest, out);
  bytes = manifest.bytes;
  return manifest.summary;
}

void mergeParts(const SweepOptions& options, const std::string& out) {
  const CompleteSweep sweep = completeSweep(options.merge);
  system::removeLeftOvers(out);
  const OutputFormat format = formatOf(sweep.manifests.front().sweep);
  const SweepManifest whole = mergeSweep(sweep, format, out);
  if (!format.isText()) writeManifest(whole, out);
  if (!options.summary.empty()) writeSummary(whole.summary, options.summary);
  std::cerr << "clearance: " << out << ": " << whole.summary.text() << '\n';
}

void writeSummary(const SweepSummary& summary, const std::string& file) {
  system::replaceFile(file, summary.toJson().dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

CoreTime::CoreTime() : begin_(coreSeconds()) {}

std::string CoreTime::text(std::uint64_t states, std::uint64_t bytes) const {
  const auto count = static_cast<double>(states);
  return threeDigits(count / std::max((coreSeconds() - begin_) / 3600.0, 1e-12)) + " states per core-hour, " +
         threeDigits(static_cast<double>(bytes) / std::max(count, 1.0)) + " bytes a state";
}

}  // namespace proximity_server::tools
