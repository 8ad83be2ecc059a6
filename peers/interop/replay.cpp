// Replays the golden rows of an exported policy with ONNX Runtime's C++ interface. Exit code 1: other actions.
//
//   g++ -std=c++17 replay.cpp -I ONNXRUNTIME/include -L ONNXRUNTIME/lib -lonnxruntime -o replay
//   ./replay policy.onnx
#include <onnxruntime_cxx_api.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

// The rows of numbers after "key": [[...], [...]] in a flat JSON text that holds nothing but such rows.
static std::vector<std::vector<float>> rows(const std::string& text, const std::string& key) {
    std::vector<std::vector<float>> all;
    const char* at = text.c_str() + text.find("\"" + key + "\":[[") + key.size() + 4;
    while (*at == '[' || (*at == ',' && at[1] == '[')) {
        if (*at == ',') ++at;
        std::vector<float> row;
        do {
            char* end = nullptr;
            row.push_back(std::strtof(at + 1, &end));
            at = end;
        } while (*at == ',');
        all.push_back(row);
        ++at;
    }
    return all;
}

int main(int count, char** arguments) {
    if (count != 2) return std::fprintf(stderr, "usage: replay policy.onnx\n"), 2;
    Ort::Env environment;
    Ort::Session session(environment, arguments[1], Ort::SessionOptions());
    Ort::AllocatorWithDefaultOptions allocator;
    const auto text = session.GetModelMetadata().LookupCustomMetadataMapAllocated("lifelike_golden", allocator);
    const auto observations = rows(text.get(), "obs"), expected = rows(text.get(), "actions");
    const auto memory = Ort::MemoryInfo::CreateCpu(OrtArenaAllocator, OrtMemTypeDefault);
    float worst = 0.0f, step = 0.0f;
    for (size_t i = 0; i < observations.size(); ++i) {
        auto row = observations[i];
        const int64_t shape[] = {1, static_cast<int64_t>(row.size())}, one[] = {1, 1};
        std::vector<Ort::Value> inputs;
        inputs.push_back(Ort::Value::CreateTensor<float>(memory, row.data(), row.size(), shape, 2));
        if (session.GetInputCount() > 1) inputs.push_back(Ort::Value::CreateTensor<float>(memory, &step, 1, one, 2));
        const char* names[] = {"obs", "time_step"};
        const char* outputs[] = {"actions"};
        auto result = session.Run(Ort::RunOptions{nullptr}, names, inputs.data(), inputs.size(), outputs, 1);
        const float* actions = result[0].GetTensorData<float>();
        for (size_t j = 0; j < expected[i].size(); ++j) worst = std::max(worst, std::fabs(actions[j] - expected[i][j]));
    }
    std::printf("%s: %zu golden rows, worst difference %.1e\n", arguments[1], observations.size(), worst);
    return observations.empty() || !(worst <= 1e-5f);
}
