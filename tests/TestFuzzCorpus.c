/* Runs the inputs that a fuzzer kept: they reach different parts of the engine, or failed once.
 *
 * Usage: TestFuzzCorpus [folder or file]...
 */
#define _POSIX_C_SOURCE 200809L /* opendir */

#include "fuzz/fuzzTarget.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int inputs = 0;

static void fail(const char* path)
{
    fprintf(stderr, "%s: %s\n", path, strerror(errno));
    exit(1);
}

static void runFile(const char* path)
{
    FILE* file = fopen(path, "rb");
    if (file == NULL || fseek(file, 0, SEEK_END) != 0)
        fail(path);
    const long size = ftell(file);
    rewind(file);
    /* Of the very size, so that a sanitizer sees what is read beyond it. */
    uint8_t* bytes = malloc(size > 0 ? (size_t)size : 1);
    if (size < 0 || bytes == NULL || fread(bytes, 1, (size_t)size, file) != (size_t)size)
        fail(path);
    fclose(file);
    printf("%s\n", path);
    fflush(stdout);
    LLVMFuzzerTestOneInput(bytes, (size_t)size);
    free(bytes);
    inputs++;
}

static void runFolder(const char* path, DIR* folder)
{
    for (const struct dirent* entry = readdir(folder); entry != NULL; entry = readdir(folder)) {
        char file[4096];
        if (entry->d_name[0] == '.')
            continue;
        snprintf(file, sizeof file, "%s/%s", path, entry->d_name);
        runFile(file);
    }
    closedir(folder);
}

int main(int argumentCount, char** arguments)
{
    LLVMFuzzerInitialize(&argumentCount, &arguments);
    for (int n = 1; n < argumentCount; n++) {
        DIR* folder = opendir(arguments[n]);
        if (folder != NULL)
            runFolder(arguments[n], folder);
        else
            runFile(arguments[n]);
    }
    return inputs == 0;
}
