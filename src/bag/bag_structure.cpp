#include <algorithm>
#include <boost/interprocess/file_mapping.hpp>
#include <boost/interprocess/mapped_region.hpp>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>

#include "bag/bag_storage.hpp"

namespace battery_sof {

namespace {

constexpr std::string_view kVersionLine = "#ROSBAG V2.0\n";
enum Operation : char {
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};
constexpr std::size_t kIndexEntrySize = 12;  // seconds, nanoseconds, offset
// of compression: messages with stamps of their own reach some ten
constexpr std::size_t kMaxRatio = 1000;
// [bytes], five times rosbag's usual chunk: allowed whatever the ratio
constexpr std::size_t kSmallChunk = 4 << 20;

/// One record: its header's fields and its data, both views into the file.
struct Record {
  std::map<std::string_view, std::string_view> fields;
  std::string_view data;

  char operation() const {
    const std::string_view operation = field("op");
    return operation.empty() ? 0 : operation.front();
  }
  std::string_view field(const char* name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? std::string_view() : found->second;
  }
  /// A field of so many bytes as a number; none where it is missing or of another size.
  template <typename Number>
  std::optional<std::uint64_t> number(const char* name) const {
    const std::string_view bytes = field(name);
    if (bytes.size() != sizeof(Number)) return std::nullopt;
    Number value = 0;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
};

/// A file's bytes, mapped rather than read: bags with pictures in them are larger than memory.
/// Nothing where it cannot be mapped.
boost::interprocess::mapped_region mapped(const std::filesystem::path& path) {
  using namespace boost::interprocess;
  try {
    return mapped_region(file_mapping(path.c_str(), read_only), read_only);
  } catch (const interprocess_exception&) {
    return mapped_region();
  }
}

std::uint32_t numberAt(std::string_view bytes, std::size_t at) {
  std::uint32_t number = 0;
  std::memcpy(&number, bytes.data() + at, sizeof(number));
  return number;
}

/// Takes records off the front of a stretch of bytes.
class RecordReader {
 public:
  RecordReader(std::string_view bytes, std::size_t file_offset)
      : bytes_(bytes), file_offset_(file_offset) {}

  bool atEnd() const { return at_ == bytes_.size(); }
  std::size_t offset() const { return file_offset_ + at_; }

  Record next() {
    Record record;
    for (std::string_view header = sized(); !header.empty();) addField(record, header);
    record.data = sized();
    Record connection;  // its data are fields too
    if (record.operation() == kConnection)
      for (std::string_view fields = record.data; !fields.empty();) addField(connection, fields);
    return record;
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw RecordingError("at byte " + std::to_string(offset()) + " " + what);
  }

 private:
  std::string_view sized() {
    if (bytes_.size() - at_ < 4) fail("the file ends inside a record");
    const std::size_t length = numberAt(bytes_, at_);
    if (length > bytes_.size() - at_ - 4) fail("a record is longer than what holds it");
    at_ += 4 + length;
    return bytes_.substr(at_ - length, length);
  }

  void addField(Record& record, std::string_view& header) const {
    const std::size_t length = header.size() < 4 ? header.size() : numberAt(header, 0);
    if (header.size() < 4 || length > header.size() - 4) fail("a record's header is damaged");
    const std::string_view field = header.substr(4, length);
    const std::size_t equals = field.find('=');
    if (equals == std::string_view::npos) fail("a record's header is damaged");
    record.fields[field.substr(0, equals)] = field.substr(equals + 1);
    header.remove_prefix(4 + length);
  }

  std::string_view bytes_;
  std::size_t file_offset_;
  std::size_t at_ = 0;
};

/// Goes from a bag's first record to its last, and holds what indices may point to.
class Walk {
 public:
  explicit Walk(std::string_view bytes)
      : bytes_(bytes), reader_(bytes.substr(kVersionLine.size()), kVersionLine.size()) {}

  void run() {
    readHeader(reader_.next());
    while (!reader_.atEnd()) {
      const std::size_t offset = reader_.offset();
      const Record record = reader_.next();
      records_.insert(offset);
      if (record.operation() == kChunk) {
        chunks_.insert(offset);
        readChunk(record);
      } else if (record.operation() == kIndex) {
        checkIndex(record);
      } else if (record.operation() == kChunkInfo) {
        checkInfo(record);
      }
    }
    const bool is_empty = records_.empty() && index_ == bytes_.size();
    if (!is_empty && records_.count(index_) == 0)
      reader_.fail("the bag's header points to byte " + std::to_string(index_) +
                   ", where no record begins");
  }

 private:
  void readHeader(const Record& header) {
    const auto index = header.number<std::uint64_t>("index_pos");
    if (header.operation() != kBagHeader || !index) reader_.fail("the bag's header is damaged");
    if (*index == 0)
      throw RecordingError(
          "the bag has no index, so it was cut off while it was recorded or copied; `rosbag "
          "reindex` may recover it");
    if (!header.field("encryptor").empty())
      reader_.fail("the bag is encrypted, expected a plain one");
    index_ = *index;
  }

  void readChunk(const Record& chunk) {
    compressed_ = chunk.field("compression") != "none";
    size_ = chunk.number<std::uint32_t>("size").value_or(0);
    messages_.clear();
    const auto begin = static_cast<std::size_t>(chunk.data.data() - bytes_.data());
    RecordReader reader(chunk.data, begin);
    const std::size_t most =
        compressed_ ? std::max(kSmallChunk, kMaxRatio * chunk.data.size()) : chunk.data.size();
    if (size_ > most)
      reader.fail("a chunk claims to hold " + std::to_string(size_) + " bytes, expected at most " +
                  std::to_string(most));
    while (!compressed_ && !reader.atEnd()) {
      const std::size_t offset = reader.offset() - begin;
      if (reader.next().operation() == kMessage) messages_.insert(offset);
    }
  }

  void checkIndex(const Record& index) const {
    const auto count = index.number<std::uint32_t>("count");
    if (!count || *count * kIndexEntrySize != index.data.size())
      reader_.fail("an index has another length than it says");
    for (std::size_t at = 0; at < index.data.size(); at += kIndexEntrySize) {
      const std::size_t offset = numberAt(index.data, at + 8);
      if (compressed_ ? offset >= size_ : messages_.count(offset) == 0)
        reader_.fail("an index points to where no message is");
    }
  }

  /// Each chunk may be listed once: listing one a thousand times makes its messages a thousand
  /// times as many.
  void checkInfo(const Record& info) {
    const auto position = info.number<std::uint64_t>("chunk_pos");
    if (!position || chunks_.erase(*position) == 0)
      reader_.fail("a chunk is listed where none is, or twice");
  }

  std::string_view bytes_;
  RecordReader reader_;
  std::uint64_t index_ = 0;
  std::unordered_set<std::uint64_t> records_, chunks_;
  // of the chunk that was read last
  bool compressed_ = false;
  std::size_t size_ = 0;
  std::unordered_set<std::size_t> messages_;  // where they begin in it
};

}  // namespace

void requireSoundBag(const std::filesystem::path& path) {
  const auto file = mapped(path);
  const std::string_view bytes(static_cast<const char*>(file.get_address()), file.get_size());
  const std::string_view line = bytes.substr(0, kVersionLine.size());
  if (line != kVersionLine) {
    const bool is_bag = line.substr(0, 7) == "#ROSBAG";
    throw RecordingError(
        path.string() +
        (is_bag ? ": a bag of another format, expected #ROSBAG V2.0; `rosbag fix` migrates it"
                : ": not a readable bag, or truncated"));
  }
  try {
    Walk(bytes).run();
  } catch (const RecordingError& error) {
    const bool has_no_index = std::string_view(error.what()).substr(0, 7) == "the bag";
    throw RecordingError(path.string() + (has_no_index ? ": " : ": damaged bag, ") + error.what());
  }
}

}  // namespace battery_sof
