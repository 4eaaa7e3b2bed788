/* Defines functions of newer glibc versions in terms of glibc 2.30, so that a plug-in linked on a
 * newer system loads on an older one. The static C++ runtime, the compiler's unwinder and our
 * threads use these functions. The linker prefers these definitions to the ones in libc. The list
 * of exports keeps them local to the plug-in. plugin_test.cmake checks which glibc versions the
 * plug-in needs, and so detects a missing function. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <pthread.h>
#include <stdint.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#if defined(__x86_64__)
#define SINCE(x86_64_version, others) x86_64_version
#elif defined(__aarch64__)
#define SINCE(x86_64_version, others) others
#else
#error "The versions of this architecture's oldest glibc are needed here."
#endif

/* ---- glibc 2.34 moved the threads into libc, under a new version ---- */

/* OLDER(name, version) declares older_NAME: the function `name` of that glibc version. */
#define OLDER(name, version)          \
  extern __typeof(name) older_##name; \
  __asm__(".symver older_" #name "," #name "@GLIBC_" version)

OLDER(pthread_create, SINCE("2.2.5", "2.17"));
OLDER(pthread_join, SINCE("2.2.5", "2.17"));
OLDER(pthread_once, SINCE("2.2.5", "2.17"));
OLDER(pthread_setname_np, SINCE("2.12", "2.17"));
OLDER(pthread_cond_clockwait, "2.30");

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
                   void* argument) {
  return older_pthread_create(thread, attributes, start, argument);
}

int pthread_join(pthread_t thread, void** result) { return older_pthread_join(thread, result); }

int pthread_once(pthread_once_t* once, void (*run)(void)) { return older_pthread_once(once, run); }

int pthread_setname_np(pthread_t thread, const char* name) {
  return older_pthread_setname_np(thread, name);
}

int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                           const struct timespec* until) {
  return older_pthread_cond_clockwait(condition, mutex, clock, until);
}

/* The runtime only tests whether this address is null, to detect whether the program has threads.
 * */
extern int __pthread_key_create(pthread_key_t* key, void (*destroy)(void*));
int __pthread_key_create(pthread_key_t* key, void (*destroy)(void*)) {
  (void)key;
  (void)destroy;
  return -1;
}

/* ---- glibc 2.32 has a flag for single-threaded processes: an engine has threads ---- */

extern char __libc_single_threaded;
char __libc_single_threaded = 0;

/* ---- glibc 2.33 exports stat and fstat as functions; statx exists since 2.28 ---- */

static int StatAt(int folder, const char* path, int flags, struct stat* out) {
  struct statx found;
  if (statx(folder, path, flags, STATX_BASIC_STATS, &found) != 0) return -1;
  memset(out, 0, sizeof *out);
  out->st_dev = makedev(found.stx_dev_major, found.stx_dev_minor);
  out->st_ino = found.stx_ino;
  out->st_mode = found.stx_mode;
  out->st_nlink = found.stx_nlink;
  out->st_uid = found.stx_uid;
  out->st_gid = found.stx_gid;
  out->st_rdev = makedev(found.stx_rdev_major, found.stx_rdev_minor);
  out->st_size = (off_t)found.stx_size;
  out->st_blksize = (blksize_t)found.stx_blksize;
  out->st_blocks = (blkcnt_t)found.stx_blocks;
  out->st_atim = (struct timespec){found.stx_atime.tv_sec, found.stx_atime.tv_nsec};
  out->st_mtim = (struct timespec){found.stx_mtime.tv_sec, found.stx_mtime.tv_nsec};
  out->st_ctim = (struct timespec){found.stx_ctime.tv_sec, found.stx_ctime.tv_nsec};
  return 0;
}

int stat(const char* path, struct stat* out) { return StatAt(AT_FDCWD, path, 0, out); }

/* On 64-bit systems, struct stat and struct stat64 are the same. */
_Static_assert(sizeof(struct stat) == sizeof(struct stat64), "a 64-bit system");
int fstat64(int file, struct stat64* out) {
  return StatAt(file, "", AT_EMPTY_PATH, (struct stat*)out);
}

/* ---- glibc 2.36 added arc4random; getrandom exists since 2.25 ---- */

uint32_t arc4random(void) {
  uint32_t number = 0;
  while (getrandom(&number, sizeof number, 0) != sizeof number) continue;
  return number;
}

/* ---- glibc 2.35 added _dl_find_object; dl_iterate_phdr is older ---- */

struct search {
  ElfW(Addr) address;
  struct dl_find_object* found;
};

/* Stops the iteration (returns 1) at the loaded object that contains the address. Stores the
 * position of its unwind tables, the segment PT_GNU_EH_FRAME. */
static int HoldsAddress(struct dl_phdr_info* object, size_t size, void* user) {
  (void)size;
  const struct search* search = user;
  int holds = 0;
  search->found->dlfo_eh_frame = NULL;
  for (int k = 0; k < object->dlpi_phnum; ++k) {
    const ElfW(Phdr)* segment = &object->dlpi_phdr[k];
    const ElfW(Addr) start = object->dlpi_addr + segment->p_vaddr;
    if (segment->p_type == PT_GNU_EH_FRAME) search->found->dlfo_eh_frame = (void*)start;
    if (segment->p_type != PT_LOAD || search->address - start >= segment->p_memsz) continue;
    search->found->dlfo_map_start = (void*)start;
    search->found->dlfo_map_end = (void*)(start + segment->p_memsz);
    holds = 1;
  }
  return holds;
}

int _dl_find_object(void* address, struct dl_find_object* found) {
  struct search search = {(ElfW(Addr))address, found};
  memset(found, 0, sizeof *found);
  const int holds = dl_iterate_phdr(HoldsAddress, &search);
  return holds && found->dlfo_eh_frame != NULL ? 0 : -1;
}
