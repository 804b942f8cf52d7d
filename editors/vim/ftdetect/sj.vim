autocmd BufRead,BufNewFile *.sj setfiletype sj
