#include "ros/background_work.hpp"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <utility>

#include "model/discrepancy_model.hpp"
#include "model/effect.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

bool isInstrument(const std::string& id) {
  return id != kDiscrepancyEffect && effectInfo(id).tier() == 'I';
}

/// Instruments marked.
std::string marked(std::vector<std::string> ids) {
  for (std::string& id : ids)
    if (isInstrument(id)) id += " (instrument)";
  return join(ids);
}

}  // namespace

BackgroundWorker::BackgroundWorker(int nice)
    : thread_(std::make_unique<boost::asio::thread_pool>(1)) {
  post([nice] { setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), nice); });
}

BackgroundWorker::~BackgroundWorker() { stop(); }

void BackgroundWorker::post(std::function<void()> work) {
  boost::asio::post(*thread_, std::move(work));
}

void BackgroundWorker::stop() {
  thread_->stop();
  thread_->join();
}

Adoption adoptionOf(const Diagnosis& diagnosis, bool allowed) {
  const bool names =
      diagnosis.verdict == Verdict::kEffect || diagnosis.verdict == Verdict::kSeveral;
  const std::vector<std::string>& effects = diagnosis.extended.fit.effects;
  if (!allowed) return {{}, "not requested: the parameter use_diagnosis is false"};
  if (!names && !diagnosis.extended.fit.discrepancy)
    return {{}, "nothing to adopt: the verdict is " + toString(diagnosis.verdict)};
  if (diagnosis.extended.fit.source)
    return {{},
            "nothing to adopt: while a charger regulates the voltage, each identification chooses "
            "its effects by itself"};
  if (diagnosis.withheld_rmse)
    return {{},
            "nothing to adopt: the extended model predicts the part that was held out worse "
            "than the base model"};
  if (std::all_of(effects.begin(), effects.end(), isInstrument))
    return {{},
            "nothing to adopt: faults of instruments should be repaired, not modelled (" +
                marked(effects) + ")"};
  return {effects, "fitted to the next windows until such a fit is refused: " + marked(effects),
          diagnosis.extended.fit.discrepancy};
}

}  // namespace battery_sof
