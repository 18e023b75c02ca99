#include "bag/format/bag_reader.hpp"

#include <algorithm>
#include <boost/interprocess/file_mapping.hpp>
#include <cstring>
#include <map>
#include <optional>
#include <stdexcept>
#include <unordered_map>
#include <unordered_set>

#include "bag/format/chunk_compression.hpp"
#include "battery_sof/recording_error.hpp"

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
constexpr std::uint64_t kIndexVersion = 1;     // of indices, and of the lists of chunks
constexpr std::size_t kIndexEntrySize = 12;    // seconds, nanoseconds, offset
constexpr std::uint64_t kSecond = 1000000000;  // [ns]
constexpr std::uint64_t kEndOfTime = (1ULL << 32) * kSecond;
// of compression: messages with stamps of their own reach some ten
constexpr std::size_t kMaxRatio = 1000;
// [bytes], five times rosbag's usual chunk: allowed whatever the ratio
constexpr std::size_t kSmallChunk = 4 << 20;

/// The index is not what a program writes: it contradicts itself, or leaves something out.
struct DamagedIndex {};

std::uint32_t numberAt(std::string_view bytes, std::size_t at) {
  std::uint32_t number = 0;
  std::memcpy(&number, bytes.data() + at, sizeof(number));
  return number;
}

using Fields = std::map<std::string_view, std::string_view>;

std::string_view fieldOf(const Fields& fields, const char* name) {
  const auto found = fields.find(name);
  return found == fields.end() ? std::string_view() : found->second;
}

std::string required(const Fields& fields, const char* name) {
  if (fields.count(name) == 0) throw DamagedIndex();
  return std::string(fields.at(name));
}

/// One record: its header's fields and its data, views into the file; a connection's data are fields
/// once more.
struct Record {
  Fields fields, data_fields;
  std::string_view data;

  std::string_view field(const char* name) const { return fieldOf(fields, name); }
  char operation() const { return field("op").empty() ? 0 : field("op").front(); }
  /// A field of so many bytes as a number; none where it is missing or of another size.
  template <typename Number>
  std::optional<std::uint64_t> number(const char* name) const {
    const std::string_view bytes = field(name);
    if (bytes.size() != sizeof(Number)) return std::nullopt;
    Number value = 0;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  template <typename Number>
  std::uint64_t requiredNumber(const char* name) const {
    const auto value = number<Number>(name);
    if (!value) throw DamagedIndex();
    return *value;
  }
};

/// Takes records off the front of a stretch of bytes.
class RecordReader {
 public:
  RecordReader(std::string_view bytes, std::size_t file_offset)
      : bytes_(bytes), file_offset_(file_offset) {}

  bool atEnd() const { return at_ == bytes_.size(); }
  std::size_t offset() const { return file_offset_ + at_; }

  Record next() {
    Record record;
    record.fields = fieldsIn(sized());
    record.data = sized();
    if (record.operation() == kConnection) record.data_fields = fieldsIn(record.data);
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

  Fields fieldsIn(std::string_view header) const {
    Fields fields;
    while (!header.empty()) {
      const std::size_t length = header.size() < 4 ? header.size() : numberAt(header, 0);
      if (header.size() < 4 || length > header.size() - 4) fail("a record's header is damaged");
      const std::string_view field = header.substr(4, length);
      const std::size_t equals = field.find('=');
      if (equals == std::string_view::npos) fail("a record's header is damaged");
      fields[field.substr(0, equals)] = field.substr(equals + 1);
      header.remove_prefix(4 + length);
    }
    return fields;
  }

  std::string_view bytes_;
  std::size_t file_offset_;
  std::size_t at_ = 0;
};

/// A file's bytes; nothing where it cannot be mapped.
boost::interprocess::mapped_region mapped(const std::filesystem::path& path) {
  using namespace boost::interprocess;
  try {
    return mapped_region(file_mapping(path.c_str(), read_only), read_only);
  } catch (const interprocess_exception&) {
    return mapped_region();
  }
}

}  // namespace

/// Goes from a bag's first record to its last, and keeps what the index says.
class BagReader::Walk {
 public:
  Walk(BagReader& bag, std::string_view bytes)
      : bag_(bag), bytes_(bytes), reader_(bytes.substr(kVersionLine.size()), kVersionLine.size()) {}

  void run() {
    readHeader(reader_.next());
    while (!reader_.atEnd()) {
      const std::size_t offset = reader_.offset();
      const Record record = reader_.next();
      records_.insert(offset);
      switch (record.operation()) {
        case kChunk: readChunk(record, offset); break;
        case kIndex: readIndex(record); break;
        case kConnection: connection_records_.push_back(record); break;
        case kChunkInfo: readInfo(record); break;
        default: break;
      }
    }
    const bool is_empty = records_.empty() && index_ == bytes_.size();
    if (!is_empty && records_.count(index_) == 0)
      reader_.fail("the bag's header points to byte " + std::to_string(index_) +
                   ", where no record begins");
    keepConnections();
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
    header_ = header;
  }

  void readChunk(const Record& record, std::size_t offset) {
    Chunk chunk{record.field("compression"), record.data, 0, false, {}};
    chunk.size = record.number<std::uint32_t>("size").value_or(0);
    is_compressed_ = chunk.compression != "none";
    messages_.clear();
    const auto begin = static_cast<std::size_t>(record.data.data() - bytes_.data());
    RecordReader reader(record.data, begin);
    const std::size_t largest =
        is_compressed_ ? std::max(kSmallChunk, kMaxRatio * record.data.size()) : record.data.size();
    if (chunk.size > largest)
      reader.fail("a chunk claims to hold " + std::to_string(chunk.size) +
                  " bytes, expected at most " + std::to_string(largest));
    while (!is_compressed_ && !reader.atEnd()) {
      const std::size_t at = reader.offset() - begin;
      if (reader.next().operation() == kMessage) messages_.insert(at);
    }
    chunk_at_[offset] = bag_.chunks_.size();
    bag_.chunks_.push_back(chunk);
  }

  /// What follows a chunk.
  void readIndex(const Record& record) {
    const auto count = record.number<std::uint32_t>("count");
    if (!count || *count * kIndexEntrySize != record.data.size())
      reader_.fail("an index has another length than it says");
    Index index;
    for (std::size_t at = 0; at < record.data.size(); at += kIndexEntrySize) {
      const std::uint32_t offset = numberAt(record.data, at + 8);
      const bool leads_nowhere =
          bag_.chunks_.empty() ||
          (is_compressed_ ? offset >= bag_.chunks_.back().size : messages_.count(offset) == 0);
      if (leads_nowhere) reader_.fail("an index points to where no message is");
      const std::uint64_t time =
          numberAt(record.data, at) * kSecond + numberAt(record.data, at + 4);
      has_damaged_index_ |= time >= kEndOfTime;
      index.entries.push_back({time, offset});
    }
    const auto connection = record.number<std::uint32_t>("conn");
    has_damaged_index_ |= !connection || record.number<std::uint32_t>("ver") != kIndexVersion;
    index.connection = static_cast<std::uint32_t>(connection.value_or(0));
    if (!bag_.chunks_.empty()) bag_.chunks_.back().indices.push_back(std::move(index));
  }

  /// Each chunk may be listed once: listing one a thousand times makes its messages a thousand
  /// times as many.
  void readInfo(const Record& record) {
    const auto position = record.number<std::uint64_t>("chunk_pos");
    const auto found = chunk_at_.find(position.value_or(0));
    if (found == chunk_at_.end() || bag_.chunks_[found->second].is_listed)
      reader_.fail("a chunk is listed where none is, or twice");
    bag_.chunks_[found->second].is_listed = true;
    has_damaged_index_ |= record.number<std::uint32_t>("ver") != kIndexVersion;
    ++infos_;
  }

  /// Those of the index that a message is of; the first of one number.
  void keepConnections() {
    if (has_damaged_index_ || header_.requiredNumber<std::uint32_t>("chunk_count") != infos_ ||
        header_.requiredNumber<std::uint32_t>("conn_count") != connection_records_.size())
      throw DamagedIndex();
    std::unordered_set<std::uint32_t> used;
    for (const Chunk& chunk : bag_.chunks_)
      for (const Index& index : chunk.indices)
        if (chunk.is_listed && !index.entries.empty()) used.insert(index.connection);
    for (const Record& record : connection_records_) {
      BagConnection connection;
      connection.id = static_cast<std::uint32_t>(record.requiredNumber<std::uint32_t>("conn"));
      connection.topic = required(record.fields, "topic");
      connection.type = required(record.data_fields, "type");
      connection.md5sum = required(record.data_fields, "md5sum");
      required(record.data_fields, "message_definition");
      if (used.erase(connection.id) > 0) bag_.connections_.push_back(std::move(connection));
    }
  }

  BagReader& bag_;
  std::string_view bytes_;
  RecordReader reader_;
  Record header_;
  std::uint64_t index_ = 0;
  std::unordered_set<std::uint64_t> records_;
  std::unordered_map<std::uint64_t, std::size_t> chunk_at_;  // where in the file -> which
  std::vector<Record> connection_records_;
  std::size_t infos_ = 0;
  bool has_damaged_index_ = false;
  // of the chunk that was read last
  bool is_compressed_ = false;
  std::unordered_set<std::size_t> messages_;  // where they begin in it
};

BagReader::BagReader(const std::filesystem::path& path) : file_(mapped(path)) {
  const std::string_view bytes(static_cast<const char*>(file_.get_address()), file_.get_size());
  const std::string_view line = bytes.substr(0, kVersionLine.size());
  if (line != kVersionLine) {
    const bool is_bag = line.substr(0, 7) == "#ROSBAG";
    throw RecordingError(
        path.string() +
        (is_bag ? ": a bag of another format, expected #ROSBAG V2.0; `rosbag fix` migrates it"
                : ": not a readable bag, or truncated"));
  }
  try {
    Walk(*this, bytes).run();
  } catch (const DamagedIndex&) {
    throw RecordingError(path.string() + ": not a readable bag: its index is damaged");
  } catch (const RecordingError& error) {
    const bool has_no_index = std::string_view(error.what()).substr(0, 7) == "the bag";
    throw RecordingError(path.string() + (has_no_index ? ": " : ": damaged bag, ") + error.what());
  }
}

void BagReader::read(const BagConnection& connection, const Take& take) const {
  for (const Chunk& chunk : chunks_) {
    std::string content;  // of a compressed chunk, once it is needed
    std::string_view bytes = chunk.compression == "none" ? chunk.bytes : content;
    for (const Index& index : chunk.indices) {
      if (!chunk.is_listed || index.connection != connection.id || index.entries.empty()) continue;
      if (bytes.empty()) bytes = content = decompressed(chunk.compression, chunk.bytes, chunk.size);
      for (const IndexEntry& entry : index.entries) {
        const Record record = RecordReader(bytes.substr(entry.offset), 0).next();
        if (record.operation() != kMessage)
          throw std::runtime_error("an index points to where no message is");
        take(entry.time, record.data);
      }
    }
  }
}

}  // namespace battery_sof
